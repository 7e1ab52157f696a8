MODULE Triggers
    ! Search and triggers: what RobotWare knows, never run.
    VAR triggdata t;
    VAR triggdata ts{3};
    VAR intnum i;
    VAR robtarget p;
    PERS bool b;

    PROC main()
        TriggIO t,5\DOp:=doX,1;
        TriggIO t,0.2\Time\GOp:=goX,3;
        TriggEquip t,10\Start,0.1\AOp:=aoX,2.5;
        TriggInt t,5,i;
        TriggL p,v100,t\T2:=t,z10,tool0;
        TriggL p,v100,ts,z10,tool0;
        SearchL\Stop,diX\Flanks,p,p,v20,tool0;
        SearchC\Sup,b,p,p,p,v20,tool0;
        TriggSpeed t,0,0.05,aoX,0.1\DipLag:=0.03;
    ENDPROC
ENDMODULE
